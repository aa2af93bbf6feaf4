"""Writes tests/files: one hem, in the files that spreadsheet programs and data libraries make of it.

Run with a Python that has openpyxl, pandas and pyarrow; LibreOffice (Debian: libreoffice-calc, python3-uno) is scripted through /usr/bin/python3:

    python scripts/lab_files.py

Every profile has the radii r(t) = R + 4 cos(5 t + phase) cm at t = 0°, 10°, ..., 350°, rounded to 0.001 cm, so a test can compute them again;
run k has R = 20 + k and phase = k. Written with openpyxl 3.1.5, pandas 2.3.3 or later, pyarrow, and LibreOffice 7.4 (see tests/files/README.md).
"""

import math
import os
import subprocess
import sys
import time

FOLDER = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "tests", "files")
ANGLES = range(0, 360, 10)


def radius(run, angle):
    t = math.radians(angle)
    return round(20 + run + 4 * math.cos(5 * t + run), 3)


def point(run, angle):
    t, r = math.radians(angle), radius(run, angle)
    return round(r * math.cos(t), 4), round(r * math.sin(t), 4)


def path(name):
    return os.path.join(FOLDER, name)


def by_libraries():
    import openpyxl
    import pandas
    import pyarrow
    import pyarrow.feather
    import pyarrow.parquet

    # A sheet per run, a merged title above the header, a formula that was never evaluated beside the table, instructions in front.
    book = openpyxl.Workbook()
    book.active.title = "Read me"
    book.active["A1"] = "Hems of spring; lengths in cm"
    for run in (1, 2):
        sheet = book.create_sheet(f"Run {run}")
        sheet.merge_cells("A1:C1")
        sheet["A1"] = f"Hem of run {run}, photographed in the morning"
        sheet.append(["operator", "N. N."])
        sheet.append(["x, cm", "y, cm", "weight"])
        for angle in ANGLES:
            sheet.append([*point(run, angle), 1.5])
        sheet["F5"] = "=SUM(A4:A39)"
    book.save(path("openpyxl_sheet_per_run.xlsx"))

    # One long sheet, the run merged over its rows, a row of units below the header.
    book = openpyxl.Workbook()
    sheet = book.active
    sheet.append(["опыт", "угол", "радиус"])
    sheet.append([None, "град", "см"])
    for run in (1, 2):
        first = sheet.max_row + 1
        for angle in ANGLES:
            sheet.append([run if sheet.max_row + 1 == first else None, angle, radius(run, angle)])
        sheet.merge_cells(f"A{first}:A{sheet.max_row}")
    book.save(path("openpyxl_long_merged.xlsx"))

    rows = [(run, *point(run, angle)) for run in (1, 2) for angle in ANGLES]
    frame = pandas.DataFrame(rows, columns=["run", "x_cm", "y_cm"])
    frame.to_parquet(path("pandas_long.parquet"), index=False)
    frame.to_csv(path("pandas_long.csv.gz"), index=False)
    pyarrow.feather.write_feather(pyarrow.Table.from_pandas(frame, preserve_index=False), path("pyarrow_long.feather"))
    wide = pandas.DataFrame([[radius(run, a) for a in ANGLES] for run in (1, 2)], columns=[f"{a}°, cm" for a in ANGLES])
    wide.insert(0, "run", [1, 2])
    table = pyarrow.Table.from_pandas(wide, preserve_index=False)
    pyarrow.parquet.write_table(table, path("pyarrow_wide.parquet"), compression="zstd")


def by_libreoffice():
    """Runs inside /usr/bin/python3, which has uno."""
    import uno
    from com.sun.star.beans import PropertyValue
    from com.sun.star.lang import Locale

    office = subprocess.Popen(
        ["soffice", "--headless", "--norestore", "--accept=socket,host=localhost,port=2002;urp;", "-env:UserInstallation=file:///tmp/hemline-lo"],
    )
    resolver = uno.getComponentContext().ServiceManager.createInstance("com.sun.star.bridge.UnoUrlResolver")
    for _ in range(120):
        try:
            context = resolver.resolve("uno:socket,host=localhost,port=2002;urp;StarOffice.ComponentContext")
            break
        except Exception:
            time.sleep(0.5)
    desktop = context.ServiceManager.createInstance("com.sun.star.frame.Desktop")

    def value(name, content):
        return PropertyValue(Name=name, Value=content)

    def fill(sheet, rows):
        for r, row in enumerate(rows):
            for c, content in enumerate(row):
                cell = sheet.getCellByPosition(c, r)
                if isinstance(content, (int, float)):
                    cell.Value = content
                elif content is not None:
                    cell.String = content

    def save(document, name, kind, options=None):
        extra = [value("FilterOptions", options)] if options else []
        document.storeToURL("file://" + os.path.abspath(path(name)), (value("FilterName", kind), *extra))

    def new(locale):
        document = desktop.loadComponentFromURL("private:factory/scalc", "_blank", 0, (value("Hidden", True),))
        formats, language = document.NumberFormats, Locale(*locale, "")
        key = formats.queryKey("0,0000", language, False)
        number = formats.addNew("0,0000", language) if key == -1 else key
        document.Sheets.getByIndex(0).getCellRangeByPosition(1, 0, 40, 100).NumberFormat = number
        return document

    # A sheet per run, titles merged above the header, in all three kinds of workbook.
    document = new(("ru", "RU"))
    for i, run in enumerate((1, 2)):
        if i:
            document.Sheets.insertNewByName("x", i)
        sheet = document.Sheets.getByIndex(i)
        sheet.Name = f"Опыт {run}"
        fill(sheet, [["Контур подола"], [], ["угол, град", "радиус, см"]] + [[a, radius(run, a)] for a in ANGLES])
        sheet.getCellRangeByName("A1:D1").merge(True)
    save(document, "libreoffice_sheet_per_run.xlsx", "Calc MS Excel 2007 XML")
    save(document, "libreoffice_sheet_per_run.xls", "MS Excel 97")
    save(document, "libreoffice_sheet_per_run.ods", "calc8")
    document.close(True)

    # Long, as Russian and German settings write it: decimal commas, legacy encodings.
    rows = [["опыт", "х, мм", "у, мм"]] + [[run, *(10 * v for v in point(run, a))] for run in (1, 2) for a in ANGLES]
    document = new(("ru", "RU"))
    fill(document.Sheets.getByIndex(0), rows)
    # Separator, quotation mark, encoding, first line, columns, language, quote all, as shown.
    save(document, "libreoffice_1251_semicolon.csv", "Text - txt - csv (StarCalc)", "59,34,34,1,,1049,false,true")
    save(document, "libreoffice_utf16_tab.tsv", "Text - txt - csv (StarCalc)", "9,34,65535,1,,1049,false,true")
    save(document, "libreoffice_utf8_comma_quoted.csv", "Text - txt - csv (StarCalc)", "44,34,76,1,,1049,false,true")
    document.close(True)

    # A column per run; German, in Windows-1252, with an umlaut and a degree sign.
    rows = [["Prüfung vom Mai"], ["Winkel (°)", "Versuch 1, cm", "Versuch 2, cm"]] + [[a, radius(1, a), radius(2, a)] for a in ANGLES]
    document = new(("de", "DE"))
    fill(document.Sheets.getByIndex(0), rows)
    save(document, "libreoffice_1252_columns.csv", "Text - txt - csv (StarCalc)", "59,34,1,1,,1031,false,true")
    save(document, "libreoffice_columns.ods", "calc8")
    document.close(True)

    # A row per run, a column per angle, the unit in a merged title.
    rows = [["", "радиус, см"], ["опыт"] + list(ANGLES)] + [[run] + [radius(run, a) for a in ANGLES] for run in (1, 2)]
    document = new(("ru", "RU"))
    sheet = document.Sheets.getByIndex(0)
    fill(sheet, rows)
    sheet.getCellRangeByName("B1:AK1").merge(True)
    save(document, "libreoffice_rows.xlsx", "Calc MS Excel 2007 XML")
    document.close(True)
    try:
        desktop.terminate()
    except Exception:
        pass
    office.wait(30)


if __name__ == "__main__":
    os.makedirs(FOLDER, exist_ok=True)
    if sys.argv[1:] == ["--libreoffice"]:
        by_libreoffice()
    else:
        by_libraries()
        subprocess.run(["/usr/bin/python3", os.path.abspath(__file__), "--libreoffice"], check=True)
