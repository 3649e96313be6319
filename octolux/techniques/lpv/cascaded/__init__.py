"""Cascaded light propagation volumes (Kaplanyan & Dachsbacher 2010)."""
