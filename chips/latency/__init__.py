"""The latency chip: evaluation and choice by the time of the first spike."""
