"""What happens when a robot is late, blocked, lost or gone: promises, new schedules, and who may follow them when."""
