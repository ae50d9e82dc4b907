"""The examples of docs/python.md are run as they stand."""
import pathlib
import re

DOCS = pathlib.Path(__file__).parents[2] / "docs" / "python.md"


def test_the_examples_of_the_docs():
    blocks = re.findall(r"```python\n(.*?)```", DOCS.read_text(), re.DOTALL)
    tests = 0
    for block in blocks:
        names = {}
        exec(compile(block, str(DOCS), "exec"), names)
        for name, value in names.items():
            if name.startswith("test_"):
                value()
                tests += 1
    assert tests >= 1
