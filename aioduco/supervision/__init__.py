"""What watches over the arm: tasks, their poller, heartbeat, stop, bring-up, the way out."""
