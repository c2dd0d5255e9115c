"""What a run looks out for: contact, links that turn, growth that steps pass over."""
