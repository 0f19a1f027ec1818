"""How fast a bag is replayed, where the time goes, and what memory that takes."""
