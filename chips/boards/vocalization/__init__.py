"""The vocalization controller: an oscillator that makes a bat's calls, the faster the nearer a target is."""
