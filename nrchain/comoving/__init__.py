"""G(X) = w(X) − g(X): a chain in axes that go along with its motion as a whole."""
