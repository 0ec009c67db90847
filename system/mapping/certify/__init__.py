"""Whether a mapped network still does its task on silicon: tasks, the network that is asked, and its runs."""
