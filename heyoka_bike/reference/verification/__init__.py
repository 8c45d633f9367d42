"""Every byte, structure and number of a set, checked without heyoka; and the runs made again."""
