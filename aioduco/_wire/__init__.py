"""The wire: only this folder and the simulator's server import Thrift."""
