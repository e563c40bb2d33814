"""Write the active curve object for knotfem. Run inside Blender: Scripting workspace, open this file, set PATH, run.

The object must hold one open spline: NURBS, or Bezier (written as the same cubic in NURBS form).
Coordinates are those of the world, so the object's own scale and place count. The first control point is the loading
end.
"""

import json

import bpy

PATH = "//knot.json"


def control_points(spline, to_world):
    """Return [x, y, z, weight] of each control point of a NURBS spline."""
    return [[*(to_world @ point.co.to_3d()), point.co.w] for point in spline.points]


def bezier_points(spline, to_world):
    """Return the control points of the cubic Bezier arcs in a row, weight 1."""
    points = []
    for point in spline.bezier_points:
        points += [point.handle_left, point.co, point.handle_right]
    return [[*(to_world @ point), 1.0] for point in points[1:-1]]


def describe(curve_object):
    """Return what the file has to hold for a curve object."""
    splines = curve_object.data.splines
    if len(splines) != 1:
        raise ValueError(f"{curve_object.name} has {len(splines)} splines, expected one")
    spline = splines[0]
    description = {"name": curve_object.name, "use_cyclic_u": spline.use_cyclic_u}
    if spline.type == "BEZIER":
        description.update(points=bezier_points(spline, curve_object.matrix_world), order_u=4)
        description.update(use_endpoint_u=True, use_bezier_u=True)
    elif spline.type == "NURBS":
        description.update(points=control_points(spline, curve_object.matrix_world), order_u=spline.order_u)
        description.update(use_endpoint_u=spline.use_endpoint_u, use_bezier_u=spline.use_bezier_u)
    else:
        raise ValueError(
            f"{curve_object.name} is a {spline.type} spline, expected NURBS or BEZIER (Curve > Set Spline Type)"
        )
    return description


def main():
    """Write the active object's curve to PATH."""
    path = bpy.path.abspath(PATH)
    text = json.dumps(describe(bpy.context.object), indent=1)
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)
    print(f"wrote {path}")


main()
