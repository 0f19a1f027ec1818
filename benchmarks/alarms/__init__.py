"""Whether the alarms warn before the belt slips, and only then."""
