"""Human-Agent Transfer: demonstrations, decision lists and the transfer methods."""
