"""A local web page that shows matches and takes demonstrations."""
