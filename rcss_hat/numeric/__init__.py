"""The ground floor: compilation, random streams, angles and the numbers of the wire."""
