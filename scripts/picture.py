"""Runs shell commands on a pseudo terminal and draws what they print: picture.py FILE.svg COMMAND..."""

import html
import os
import pty
import re
import subprocess
import sys
import textwrap

COLUMNS = 112
WIDTH, HEIGHT, MARGIN = 8.0, 17, 16  # of a character, of a line, around
COLOURS = {"31": "#ff7b72", "32": "#7ee787", "33": "#e3b341", "34": "#79c0ff", "35": "#d2a8ff", "36": "#76e3ea"}


def output_of(command):
    """Everything that it prints on a terminal of COLUMNS columns, as lines with SGR sequences."""
    terminal, end = pty.openpty()
    os.set_blocking(terminal, True)
    environment = dict(os.environ, TERM="xterm", COLUMNS=str(COLUMNS))
    subprocess.run(["stty", "cols", str(COLUMNS), "rows", "50"], stdin=end, check=True)
    process = subprocess.Popen(command, shell=True, stdin=end, stdout=end, stderr=end, env=environment)
    os.close(end)
    text = b""
    while True:
        try:
            some = os.read(terminal, 65536)
        except OSError:  # the last one has closed it
            break
        if not some:
            break
        text += some
    process.wait()
    # What was overwritten in its line (a progress bar) is not shown.
    lines = text.decode().replace("\r\n", "\n").rstrip("\n").split("\n")
    return [re.sub(r"\x1b\[K", "", line.split("\r")[-1]) for line in lines]


def wrapped(line):
    """A line as the terminal breaks it; colours stay with their first part."""
    if len(re.sub(r"\x1b\[[0-9;]*m", "", line)) <= COLUMNS:
        return [line]
    return textwrap.wrap(line, COLUMNS, drop_whitespace=False, break_long_words=True)


def spans(line):
    """The line as tspans; columns are pinned, whatever font shows it."""
    colour, weight, column, parts = None, None, 0, []
    for piece in re.split(r"(\x1b\[[0-9;]*m)", line):
        if piece.startswith("\x1b"):
            for code in piece[2:-1].split(";"):
                if code in ("", "0"):
                    colour = weight = None
                elif code == "1":
                    weight = "bold"
                elif code in COLOURS:
                    colour = COLOURS[code]
            continue
        for word in re.finditer(r"\S+(?: \S+)*", piece):
            x = MARGIN + (column + word.start()) * WIDTH
            style = (f' fill="{colour}"' if colour else "") + (f' font-weight="{weight}"' if weight else "")
            length = f' textLength="{len(word.group()) * WIDTH:.1f}"'
            parts.append(f'<tspan x="{x:.1f}"{length}{style}>{html.escape(word.group())}</tspan>')
        column += len(piece)
    return "".join(parts)


def main(path, commands):
    lines = []
    for command in commands:
        lines.append("\x1b[1m$ " + command + "\x1b[0m")
        for line in output_of(command):
            lines.extend(wrapped(line))
        lines.append("")
    lines.pop()
    width = int(COLUMNS * WIDTH + 2 * MARGIN)
    height = len(lines) * HEIGHT + 2 * MARGIN
    with open(path, "w", encoding="utf-8") as file:
        file.write(
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" '
            f'height="{height}" role="img" aria-label="A session with fleetpub">\n'
            f'<rect width="100%" height="100%" rx="8" fill="#0d1117"/>\n'
            '<g font-family="ui-monospace, \'DejaVu Sans Mono\', Menlo, Consolas, monospace" font-size="13" fill="#e6edf3">\n'
        )
        for number, line in enumerate(lines):
            y = MARGIN + (number + 0.75) * HEIGHT
            if line:
                file.write(f'<text y="{y:.1f}" xml:space="preserve">{spans(line)}</text>\n')
        file.write("</g>\n</svg>\n")


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2:])
