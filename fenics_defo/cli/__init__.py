"""The console commands: parse, call, print. Nothing heavy is imported before there is work."""
