"""Keys of `noctule serve`."""

from __future__ import annotations

from system.meaning import meanings

SERVE = meanings("""
chip       string  -  name of the chip
pace       string  -  `fast` or `real`
time_s     number  s  the chip's time at the end
behind_s   number  s  by how much the chip was behind the wall's clock at most, at real pace
slipped_s  number  s  time of the wall's clock that was lost, since the chip could not keep up
clients    integer -  clients that there were
events     object  -  events of all clients, by what became of them
events.taken        integer  -  that the chip took
events.sent         integer  -  spikes sent to clients
events.unknown      integer  -  of no address of the chip
events.backwards    integer  -  before the one ahead of them, or the chip's time
events.far          integer  -  more than an hour ahead of the chip's time
events.late         integer  -  of those taken, how many at the chip's time, since their own had passed
events.dropped_in   integer  -  that found the queue full
events.dropped_out  integer  -  spikes that found a client's queue full
events.missed       integer  -  lost on the way over UDP; of jAER's format datagrams
events.refused      integer  -  of clients while another one led the time
events.left         integer  -  that waited for their time when their client went
events.chip_lost    integer  -  lost within the chip
on_chip    object  -  what the chip counted
on_chip.*  integer -  a count of its own, by its name
""")
