"""The vocalization controller: how long a bat waits until its next call."""
