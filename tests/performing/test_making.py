"""Performers are made of packs, and not of names."""

import pytest

import lipsync_lang as ll


def test_a_performer_of_names_says_how_one_is_made():
    with pytest.raises(ll.LipsyncError, match=r'`ll\.resolve\("english", "facefx"\)`'):
        ll.Performer("english", "facefx")
