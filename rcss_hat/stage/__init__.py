"""Players over UDP: connections, clients and the launcher of whole teams."""
