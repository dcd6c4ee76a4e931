"""The server's language, protocol version 11: bytes to records and back, without any input or output."""
