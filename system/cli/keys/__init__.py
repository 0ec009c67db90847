"""Meanings of the keys of the commands' JSON documents (`system.meaning`), each told once."""
