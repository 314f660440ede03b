"""The coupled system as it is scheduled, linearised: poles, margins, stability maps."""
