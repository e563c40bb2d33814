import knotfem as kf

scene = kf.load_scene("bowline", {"model": "rod", "contact.friction": 0.37, "steps.pull.displacement": "20 mm"})
run = kf.pull(scene)
print(f"knot {run.knot}, {run.force.at(20.0):.3f} N at 20 mm, {run.cost.cpu_s:.1f} s of CPU time")
run.force.plot().figure.savefig("force.png")
profile = run.tension(at="12 mm")
print(f"tension from {profile.tension.max():.3f} N at the pulled end to {profile.tension.min():.3f} N")
profile.plot().figure.savefig("tension.png")
run.states[-1].render("knot.png", colour="strain")
