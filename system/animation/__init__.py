"""Films as moving pictures: a frame of a film at a time, and the files that frames are written into."""
