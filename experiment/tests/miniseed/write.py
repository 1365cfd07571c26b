"""Writes the MiniSEED files beside this one, with pymseed from PyPI (1.0.1): 500 samples at 100 Hz, of a motion whose steps
from sample to sample need every packing of Steim's two compressions.

    pip install pymseed && python write.py
"""

import math

from pymseed import DataEncoding, MS3Record


def count(i):
    """The i-th sample: sweeps from a few counts to millions and back."""
    return round(10.0 ** (7.5 * math.sin(math.pi * i / 500) ** 2) * math.sin(0.37 * i))


def write(name, encoding, sample_type, samples, gap=False, version=2):
    parts = [samples[:300], samples[300:]]
    with open(name, "wb") as file:
        for k, part in enumerate(parts):
            record = MS3Record()
            record.sourceid = "FDSN:XX_TEST__H_N_Z"
            record.formatversion = version
            record.reclen = 512
            record.samprate = 100.0
            record.encoding = encoding
            start = "2026-01-31T23:59:58.000000Z" if k == 0 else "2026-02-01T00:00:01.000000Z"
            if gap and k == 1:
                start = "2026-02-01T00:00:01.500000Z"
            record.set_starttime_str(start)
            for packed in record.generate(part, sample_type):
                file.write(packed)


counts = [count(i) for i in range(500)]
write("steim1.mseed", DataEncoding.STEIM1, "i", counts)
write("steim2.mseed", DataEncoding.STEIM2, "i", counts)
write("int32.mseed", DataEncoding.INT32, "i", counts)
write("float32.mseed", DataEncoding.FLOAT32, "f", [1e-7 * c for c in counts])
write("float64.mseed", DataEncoding.FLOAT64, "d", [1e-7 * c for c in counts])
write("gap.mseed", DataEncoding.STEIM2, "i", counts, gap=True)
write("version3-steim2.mseed", DataEncoding.STEIM2, "i", counts, version=3)
write("version3-int32.mseed", DataEncoding.INT32, "i", counts, version=3)
write("version3-float32.mseed", DataEncoding.FLOAT32, "f", [1e-7 * c for c in counts], version=3)
