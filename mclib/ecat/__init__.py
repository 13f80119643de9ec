"""The simulated EtherCAT bus: what is on it, from plc.toml or an ENI file, written to the image before the first scan.

docs/ecat.md describes the slaves and the keys. The bus itself runs in ST (mclib/library/ecat).
"""

from mclib.ecat.bus import Bus, BusError
from mclib.ecat.image import configure
from mclib.ecat.table import default, read

__all__ = ["Bus", "BusError", "configure", "default", "read"]
