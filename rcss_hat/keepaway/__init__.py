"""The Keepaway task: state variables, macro-actions, keeper, taker and the fixed policies."""
