"""The wire: the only part of the package, beside the simulator's server, that knows Thrift."""
