"""What a model is: variables, arithmetic, integration, and an instance that steps."""
