"""Approach: a bat that closes in on a target by sonar."""
