"""Many runs for one question: sweeps, the separating line, calibration, virtual experiments."""
