"""Finds the effect that a campaign's model lacks, and how far the error falls with it: ``... FOLDER``."""

import sys

import sealegs

campaign = sealegs.Campaign.read(sys.argv[1])
verdict = sealegs.diagnose(campaign)
print(verdict.sentence)
if verdict.effects:
    print(sealegs.add(verdict.effects, campaign).sentence)
