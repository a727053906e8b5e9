"""Many runs: jobs as data, where they run, and the results that they leave."""
