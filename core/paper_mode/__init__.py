"""Mode PAPER: the tables of the paper and its sampler [Huang07]."""
