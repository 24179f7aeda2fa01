"""Tests the kit itself: robots and mediators that are wrong in one thing each, and the checks that must find it."""
