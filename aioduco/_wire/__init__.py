"""The wire protocol: only this folder and the simulator's server import Thrift."""
