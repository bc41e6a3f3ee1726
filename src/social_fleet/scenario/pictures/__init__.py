"""Pictures of maps, plans, schedules and runs."""
