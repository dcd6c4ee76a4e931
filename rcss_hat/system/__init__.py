"""What this program needs of the operating system: files written whole, one writer per folder, workers that end."""
