"""The coupled loops and the recipes that tie the stages together."""
