//! Testing automated-vehicle controllers against pedestrians who behave like people.
