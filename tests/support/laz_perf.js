// Unpacks LAZ files with laz-perf, another decoder: node laz_perf.js MODULES IN.laz OUT [IN.laz OUT]... writes the points'
// records. What laz-perf does not read is not written.
"use strict";
const fs = require("fs");
const { createLazPerf } = require(process.argv[2] + "/laz-perf");

function unpack(perf, path) {
    const file = fs.readFileSync(path);
    const bytes = perf._malloc(file.length);
    perf.HEAPU8.set(file, bytes);
    const laz = new perf.LASZip();
    laz.open(bytes, file.length);
    const size = laz.getPointLength(), count = Number(laz.getCount());
    const record = perf._malloc(size);
    const out = Buffer.alloc(size * count);
    for (let i = 0; i < count; i++) {
        laz.getPoint(record);
        out.set(perf.HEAPU8.subarray(record, record + size), i * size);
    }
    perf._free(record);
    perf._free(bytes);
    laz.delete();
    return out;
}

(async () => {
    for (let i = 3; i + 1 < process.argv.length; i += 2) {
        const perf = await createLazPerf(); // a file that it cannot read may leave it in pieces
        try {
            fs.writeFileSync(process.argv[i + 1], unpack(perf, process.argv[i]));
        } catch (e) {
            console.error(process.argv[i] + ": " + e);
        }
    }
})();
