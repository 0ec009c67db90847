"""Milde et al. 2017: obstacle avoidance and target acquisition on ROLLS."""
