"""What is made of a family's plan: for the reversed chain, an imperfect arm, a joint that is given."""
