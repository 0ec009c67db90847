"""Car: a wheeled robot that drives through pipes by sonar."""
