"""What surfaces and strands make of light, from parameters to lobes to numbers."""
