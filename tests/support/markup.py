"""Check the HTML that a notebook shows of a result."""

from html.parser import HTMLParser

TAGS = {"table", "caption", "thead", "tbody", "tr", "th", "td"}

LONGEST = 12_000
"""Most characters: more does not fit a screen."""


class _Reader(HTMLParser):
    """Notes the texts, and asserts that tags are closed in order and have no attributes."""

    def __init__(self):
        super().__init__(convert_charrefs=True)
        self.open, self.texts, self.widths = [], [], []

    def handle_starttag(self, tag, attributes):
        assert tag in TAGS
        assert not attributes
        if tag == "tr":
            self.widths.append(0)
        if tag in ("th", "td"):
            self.widths[-1] += 1
        self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        assert self.open[-1] in ("caption", "th", "td")
        self.texts.append(data)


def assert_plain_table(html):
    """One well-formed table without attributes, scripts or styles; returns its texts."""
    assert html.startswith("<table>")
    assert len(html) <= LONGEST
    reader = _Reader()
    reader.feed(html)
    reader.close()
    assert not reader.open
    # the last row may count what is left out in one cell
    assert len(set(reader.widths[:-1])) <= 1
    return reader.texts
