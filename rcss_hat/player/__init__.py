"""One player, sans-IO: beliefs about the world, prediction, and the skills that become commands."""
