"""What accuracy costs in time: estimators side by side, images compared, effects taken out, and the page."""
