"""The collisions table and the law: schema, files, tables that others wrote."""
