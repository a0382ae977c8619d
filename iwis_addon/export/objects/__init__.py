"""What objects say of themselves: rays, links, groups, properties."""
