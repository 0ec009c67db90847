"""Parts of the NEF chip under the law with second-order effects, each at its own operating point."""
