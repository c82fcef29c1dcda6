"""What keeps the rest sound: numbers from outside read in one way, arrays that stay read-only, forks that wait."""
