"""How fast nrchain is, against common practice, with effects left out, and with N."""
