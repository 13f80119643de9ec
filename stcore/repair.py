class Repairs:
    def __init__(self, machine): self.m = machine
    def repair(self, at):
        t = self.m.tokens
        self.m.reporter.add("E0101", t.source, t.starts[at], t.ends[at], found=t.texts[at] or "the end of the file")
        return -1
    too_deep = repair
