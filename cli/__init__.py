"""The command line of knotfem: one file a verb, each of which calls one public function of the library."""
