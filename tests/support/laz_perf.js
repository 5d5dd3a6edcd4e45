// Unpacks a LAZ file with laz-perf, another decoder: node laz_perf.js MODULES [IN.laz OUT] writes the points' records to
// OUT. No OUT is written of a file that laz-perf does not read. Without files, only loads laz-perf.
"use strict";
const fs = require("fs");
const [modules, path, out] = process.argv.slice(2);
const { createLazPerf } = require(modules + "/laz-perf");

function unpack(perf) {
    const file = fs.readFileSync(path);
    const bytes = perf._malloc(file.length);
    perf.HEAPU8.set(file, bytes);
    const laz = new perf.LASZip();
    laz.open(bytes, file.length);
    const size = laz.getPointLength(), count = Number(laz.getCount());
    const record = perf._malloc(size);
    const records = Buffer.alloc(size * count);
    for (let i = 0; i < count; i++) {
        laz.getPoint(record);
        records.set(perf.HEAPU8.subarray(record, record + size), i * size);
    }
    return records;
}

createLazPerf().then(perf => {
    try {
        if (path)
            fs.writeFileSync(out, unpack(perf));
    } catch (e) {
        console.error(path + ": " + e);
    }
});
