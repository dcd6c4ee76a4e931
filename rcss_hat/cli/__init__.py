"""The ``rcss-hat`` command."""
